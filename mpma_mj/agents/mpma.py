"""The Multiple Paired Models Architecture of Tidemann & Öztürk 2008."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import dm_env
import numpy as np
from numpy.typing import NDArray

from mpma_mj.agents import responsibility as gating
from mpma_mj.agents.gains import Gains
from mpma_mj.esn import ReadoutBank, ReservoirBank
from mpma_mj.feedback import feedback_action
from mpma_mj.randomness import stream

Array = NDArray[np.float64]

import os
P=dict(phi=.7,rho=1e-3,gamma=2.,beta=1.5,rate=.15,g_sigma=.144,g_ridge=1e-2,perf='1',fwd='total',kw=1)
for kv in os.environ.get('P','').split(','):
    if kv:
        k,v=kv.split('='); P[k]=type(P[k])(v)

class MPMA:
    def __init__(self, modules, nodes, context_size, rule, v, dt, seed):
        self.M=modules; self.N=nodes; self.rule=rule; self.v=v; self.dt=dt; self.seed=seed
        mk=lambda name,inp: ReservoirBank(modules,inp,nodes,radius=.1,noise=.2,rng=stream(seed,'weights',name))
        self.im,self.fm,self.rp=mk('inverse',24),mk('forward',20),mk('rp',context_size)
        kw=dict(forgetting=P['phi'],ridge=P['rho']) if rule=='weighted' else dict(forgetting=0.,ridge=P['g_ridge'])
        self.imr=ReadoutBank(np.zeros((modules,8,nodes+24)),**kw)
        self.fmr=ReadoutBank(np.zeros((modules,12,nodes+20)),**kw)
        w=np.zeros((modules,1,nodes+context_size)); w[:,0,nodes:]=stream(seed,'rp0').random((modules,context_size))
        self.rpr=ReadoutBank(w,**kw)
        self.gains=Gains(); self.sigma=.5 if rule=='weighted' else P['g_sigma']
    def reset(self, episode):
        self.rng=stream(self.seed,'noise',episode)
        for b in (self.im,self.fm,self.rp): b.reset()
        self.rec=[]; self.pred=None
    def act(self, o):
        x=o['posture']
        zr=self.rp.step(o['context'],self.rng); p=np.clip(self.rpr(zr)[:,0],.01,1)
        l=np.ones(self.M) if self.pred is None else gating.likelihood(gating.prediction_errors(self.pred,x),self.sigma)
        lam=gating.responsibilities(p,l)
        zi=self.im.step(np.concatenate([x,o['target']]),self.rng); ui=np.clip(self.imr(zi),-1,1)
        ufb=feedback_action(o['joint_angles'],o['reference'],self.v,self.dt)
        u=np.clip(self.gains.inverse*(lam@ui)+self.gains.feedback*ufb,-1,1)
        if P['fwd']=='total': fin=np.concatenate([u,x])
        else: fin=np.concatenate([ui,np.broadcast_to(x,(self.M,12))],1)
        zf=self.fm.step(fin,self.rng); self.pred=self.fmr(zf)
        self.rec.append((p,lam,zr,zi,ui,ufb,u,zf,self.pred,x,o['joint_angles'],o['reference'],o['context']))
        return u
    def observe(self, ts): self.last=ts.observation
    def learn(self):
        p,lam,zr,zi,ui,ufb,u,zf,pred,x,q,ref,ctx=map(np.stack,zip(*self.rec))
        o=self.last
        x1=np.concatenate([x[1:],o['posture'][None]]); r1=np.concatenate([ref[1:],o['reference'][None]])
        fb1=np.concatenate([ufb[1:],feedback_action(o['joint_angles'],o['reference'],self.v,self.dt)[None]])
        K=self.gains.feedback;L=self.gains.inverse
        pe=100*np.abs(x1-r1).mean()/2
        mix=np.einsum('tm,tmd->td',lam,pred); perr=100*np.abs(mix-x1).mean()/2
        rpe=100*np.abs(p/p.sum(1,keepdims=True)-lam).mean()
        ratio=np.abs(K*ufb).sum()/np.abs(u).sum()
        C=ctx.shape[1]; lab=ctx.argmax(1); dom=lam.argmax(1)
        act=[sum((lam[lab==c,m]>.1).mean()>=.25 for m in range(self.M)) for c in range(C)]
        J=np.zeros((C,self.M)); np.add.at(J,(lab,dom),1); J/=J.sum(); 
        a=J.sum(1,keepdims=True);b=J.sum(0,keepdims=True); nz=J>0
        nmi=(J[nz]*np.log((J/(a@b))[nz])).sum()/np.log(C)
        used=len({int(np.bincount(dom[lab==c],minlength=self.M).argmax()) for c in range(C)})
        m=dict(pe=pe,perr=perr,rpe=rpe,ratio=ratio,K=K,L=L,sigma=self.sigma,act=act,nmi=nmi,used=used,final=self.gains.final)
        if self.rule=='weighted':
            self.fmr.fit(zf,x1[:,None],lam)
            self.imr.fit(zi,np.clip(u+fb1,-1,1)[:,None],lam)
            self.rpr.fit(zr,gating.commitment_target(lam,P['gamma'],P['beta'])[:,:,None])
            self.sigma=max(.02,float(np.sqrt((lam*gating.prediction_errors(pred,x1)).sum(1).mean())))
        else:
            self.fmr.fit(zf,pred+lam[:,:,None]*(x1[:,None]-pred))
            self.imr.fit(zi,ui+lam[:,:,None]*(K*fb1)[:,None])
            self.rpr.fit(zr,lam[:,:,None])
        if P['perf']=='1': perf=1.
        elif P['perf']=='pred': perf=float(np.clip((8-perr)/5,0,1))
        self.gains=self.gains.after(perf,P['rate'])
        return m
